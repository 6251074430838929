"""PSDs in tables: break points with slopes, tables of accelerations, third octaves."""
