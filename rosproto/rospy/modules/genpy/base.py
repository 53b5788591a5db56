"""Which field types are simple."""

SIMPLE_TYPES_DICT = {
    "int8": "b",
    "uint8": "B",
    "bool": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
    "float32": "f",
    "float64": "d",
    "char": "B",
    "byte": "b",
}
SIMPLE_TYPES = list(SIMPLE_TYPES_DICT)


def is_simple(type_):
    """True for a type of fixed size that struct knows."""
    return type_ in SIMPLE_TYPES_DICT
