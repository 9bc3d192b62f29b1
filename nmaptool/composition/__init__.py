"""Normal maps edited as vectors: blending, placing, transforming, converting, recipes."""
