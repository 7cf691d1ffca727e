# SPDX-License-Identifier: GPL-3.0-or-later
"""Small pictures for the tests."""
import io

import numpy
from PIL import Image


def png(rows):
    """The bytes of an 8-bit RGB PNG; `rows` of pixels of three numbers."""
    out = io.BytesIO()
    Image.fromarray(numpy.array(rows, numpy.uint8)).save(out, "PNG")
    return out.getvalue()
