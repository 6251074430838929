"""Tables as people export them: separators, marks of decimals, headers, units and number forms."""
