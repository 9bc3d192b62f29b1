from .conversion import convert as convert
from .copying import copy as copy
from .large_relief import relief as relief
from .pyramid import overview as overview
