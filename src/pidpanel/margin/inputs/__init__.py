"""The inputs of a study with spreads, as standard normal scores."""
