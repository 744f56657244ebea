"""What a building is made of, still pure geometry: panels, cells, beams, connectors."""
