// Second-order quads with a middle node, Gmsh's default.
Include "square.geo";
Mesh.ElementOrder = 2;
