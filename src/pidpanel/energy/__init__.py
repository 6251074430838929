"""Statistical energy of a panel: the response at frequencies above those of its modal answer."""
