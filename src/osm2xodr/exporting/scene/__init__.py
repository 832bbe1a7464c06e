"""Roads, ground and buildings as a scene of meshes, in tiles."""
