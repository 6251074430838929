"""Particle impact damping of honeycomb panels under launch sound, from grains to PSDs."""
