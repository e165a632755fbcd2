"""The flexible structure: mesh, plate elements and modes."""
