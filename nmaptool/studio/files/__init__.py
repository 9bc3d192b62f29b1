"""Files of the document: dropped, added, saved, recovered and exported."""
