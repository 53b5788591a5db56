"""Tolerance of tf.transformations for rounding errors."""

import numpy

EPS = numpy.finfo(float).eps * 4.0
