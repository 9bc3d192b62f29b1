"""What a picture means as a normal map: codes, channels, background, conventions."""
