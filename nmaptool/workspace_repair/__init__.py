"""What an image editor did to a packed layer, told from its codes and the signature it was packed with."""
