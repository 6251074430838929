"""Jobs of the workflow, each a process of its own: ``python -m scripts.<name>``."""

from pidpanel.provenance.job import tell_of_memory

# before a script imports what takes the memory
tell_of_memory()
