"""Picture files: PNG, EXR, TIFF, JPEG, BMP."""
