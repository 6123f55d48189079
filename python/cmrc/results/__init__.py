"""The six claims of the paper (section 7), each with its experiment: ``python -m cmrc.results`` regenerates docs/results.md.

Each claim is a module with ``Parameters``, ``QUICK`` (a shrunken version), and the functions ``runs`` (what to run), ``rows`` (the numbers, from the
runs' reports), ``verdict`` (from the rows alone), ``section`` (text and tables) and ``draw`` (the plot).
"""
