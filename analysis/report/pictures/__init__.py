"""Pictures of beds: the scene, a renderer of spheres, panels for pages, and files for ParaView."""
