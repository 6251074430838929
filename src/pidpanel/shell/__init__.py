"""Shells: curved, kinked and stiffened structures as the matrices of a plate."""
