"""The panel: mesh, plate, modes."""
