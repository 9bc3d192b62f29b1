from .large_relief import relief as relief
