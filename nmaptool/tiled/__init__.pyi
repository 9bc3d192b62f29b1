from .arrays import read_array as read_array
from .arrays import write_array as write_array
from .conversion import convert as convert
from .copying import copy as copy
from .large_relief import relief as relief
from .pyramid import overview as overview
