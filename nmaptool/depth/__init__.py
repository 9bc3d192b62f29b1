"""Convert depth and height pictures to normals: heights, jumps, fitted slopes. No module here reads or writes files."""
