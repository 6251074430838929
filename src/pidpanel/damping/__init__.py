"""C_e and m_a of a filled patch at given frequencies and motion: one question, several answers."""
