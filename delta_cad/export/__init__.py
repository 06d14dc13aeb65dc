"""The files a build leaves behind: STEP, meshes, GLB, bill of materials, mass properties, pictures, manifest."""
