"""Layered files of image editors: PSD, ORA, TIFF, EXR."""
