from .conversion import convert as convert
from .conversion import copy as copy
from .large_relief import relief as relief
