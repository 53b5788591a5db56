"""The version of the whole distribution; the build reads it here."""

__all__ = ["__version__"]

__version__ = "0.9.0"
