"""What a mission author works with: texts, compiler, check, graph, differences."""
