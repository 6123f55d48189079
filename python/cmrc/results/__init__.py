"""The six claims of paper section 7 and the cost of missed deadlines, each with its experiment: ``python -m
cmrc.results`` regenerates docs/results.md. Each claim is a module with a class (``claim.Claim``)."""
