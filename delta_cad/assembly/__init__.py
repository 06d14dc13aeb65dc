"""The placed machine: every part on its link, its joints and its meshes."""
