Include "square.geo";
Rotate {{1, 0, 0}, {0, 0, 0}, Pi / 4} { Surface{1}; }
