"""One question, several answers: C_e and m_a of a filled patch at these frequencies for this motion."""
