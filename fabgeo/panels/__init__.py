"""What a patch can be made as: plane, cylinder, cone, developable; unfolding."""
