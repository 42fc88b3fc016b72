"""From tissue labels to meshes, and from meshes back to voxels."""
