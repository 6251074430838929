"""The mesh of a Nastran deck: the modes of the panel that comes with pidpanel as a .bdf file."""

import pidpanel

modes = pidpanel.Model("bdf_panel.yaml").modes()
for mode in range(1, 6):
    one = modes.sel(mode=mode)
    print(f"mode {mode}: {float(one['natural_frequency']):.1f} {one['natural_frequency'].units}")
