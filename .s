	.file	""
	.version	40

	.data
data_sec:
	.end
