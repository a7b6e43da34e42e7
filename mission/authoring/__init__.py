"""The tools of a mission author: texts, compiler, check, graph, differences."""
