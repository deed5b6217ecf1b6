// Cantilever: a bar of 1000 mm x 200 mm, clamped on the left, loaded on the right.
//
//      top
//      +-----------------+---------+-----------------+
// clamp|      left       |  band   |      right      + tip      load
//      +-----------------+---------+-----------------+
//    corner            bottom
//      x = 0        band_start  band_end          x = 1000
//
// One file for all cantilever cases. The pipeline decides which surface is peridynamic and which
// is finite elements: band alone, all three, or none. With band_start = 0 the band begins at the
// clamp and there is no surface "left"; with band_end = 1000 there is no surface "right".
//
// Units: mm. A parameter can be set in the pipeline (geometry: parameters:), on Gmsh's command line
// (-setnumber element 20) or in Gmsh's window; the values below are the defaults.

DefineConstant[
  element    = {10,  Name "Mesh/Element size [mm]"},           // must divide 100
  order      = {2,   Name "Mesh/Order", Choices{1, 2}},        // 1: 4-node, 2: 8-node quads
  triangles  = {0,   Name "Mesh/Triangles", Choices{0, 1}},    // 1: 3- or 6-node triangles
  band_start = {400, Name "Geometry/Band starts at x [mm]"},   // multiples of element
  band_end   = {600, Name "Geometry/Band ends at x [mm]"}
];

length = 1000;
height = 200;

// ---- Are the parameters sound? Error(...) stops the run with its text.
If (element <= 0 || Fabs(height / 2 / element - Round(height / 2 / element)) > 1e-9)
  Error("element = %g mm does not divide half the height, %g mm", element, height / 2);
  Abort;
EndIf
If (band_start < 0 || band_end > length || band_start >= band_end)
  Error("the band from x = %g to %g mm must lie within the bar, 0 to %g mm",
        band_start, band_end, length);
  Abort;
EndIf
If (Fabs(band_start / element - Round(band_start / element)) > 1e-9 ||
    Fabs(band_end / element - Round(band_end / element)) > 1e-9)
  Error("the band from x = %g to %g mm must start and end at multiples of element = %g mm",
        band_start, band_end, element);
  Abort;
EndIf

// ---- Verticals: the two ends, and the borders of the band that lie between them.
x() = {0};
If (band_start > 0)
  x() += {band_start};
EndIf
If (band_end < length)
  x() += {band_end};
EndIf
x() += {length};
last = #x() - 1;

rows = Round(height / element);
For i In {0:last}
  Point(10 + i) = {x(i), 0, 0};
  Point(20 + i) = {x(i), height, 0};
  If (i < last)
    Line(30 + i) = {10 + i, 20 + i};
    Transfinite Curve {30 + i} = rows + 1;
  EndIf
EndFor

// The right end is two lines, so that the tip at mid-height is a point of the geometry.
Point(1) = {length, height / 2, 0};
Line(1) = {10 + last, 1};
Line(2) = {1, 20 + last};
Transfinite Curve {1, 2} = rows / 2 + 1;

// ---- One rectangle between each vertical and the next, with a structured mesh.
left() = {};
band() = {};
right() = {};
bottom() = {};
top() = {};
For i In {0:last - 1}
  columns = Round((x(i + 1) - x(i)) / element);
  Line(40 + i) = {10 + i, 11 + i};
  Line(50 + i) = {20 + i, 21 + i};
  Transfinite Curve {40 + i, 50 + i} = columns + 1;
  bottom() += {40 + i};
  top() += {50 + i};

  If (i + 1 < last)
    Curve Loop(60 + i) = {40 + i, 31 + i, -(50 + i), -(30 + i)};
  Else
    Curve Loop(60 + i) = {40 + i, 1, 2, -(50 + i), -(30 + i)};
  EndIf
  Plane Surface(70 + i) = {60 + i};
  Transfinite Surface {70 + i} = {10 + i, 11 + i, 21 + i, 20 + i};
  If (!triangles)
    Recombine Surface {70 + i};
  EndIf

  middle = (x(i) + x(i + 1)) / 2;
  If (middle < band_start)
    left() += {70 + i};
  ElseIf (middle < band_end)
    band() += {70 + i};
  Else
    right() += {70 + i};
  EndIf
EndFor

// ---- Names, by which the pipeline refers to the parts.
If (#left() > 0)
  Physical Surface("left") = {left()};
EndIf
Physical Surface("band") = {band()};
If (#right() > 0)
  Physical Surface("right") = {right()};
EndIf
Physical Curve("clamp") = {30};
Physical Curve("load") = {1, 2};
Physical Curve("bottom") = {bottom()};
Physical Curve("top") = {top()};
Physical Point("corner") = {10};
Physical Point("tip") = {1};

// ---- Second-order quads have 8 nodes, not 9.
Mesh.ElementOrder = order;
Mesh.SecondOrderIncomplete = 1;
