"""What is in a picture or a film, as JSON: size, and the share of each of its commonest colours.

    look_at.py FILE.png
"""

import collections
import json
import sys

from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader

reader = vtkPNGReader()
reader.SetFileName(sys.argv[1])
reader.Update()
image = reader.GetOutput()
width, height, _ = image.GetDimensions()
pixels = vtk_to_numpy(image.GetPointData().GetScalars())[:, :3]
counted = collections.Counter(map(tuple, pixels.tolist()))
print(json.dumps({
    "size": [width, height],
    "colours": [[list(colour), count / len(pixels)] for colour, count in counted.most_common(400)],
}))
