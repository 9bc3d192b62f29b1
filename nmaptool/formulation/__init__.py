"""What is solved: which faces act, which vertices are held, which slopes and heights are aimed at, in pixels."""
