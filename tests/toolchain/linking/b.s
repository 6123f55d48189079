	.text
	.global ext, other
other:	.word other
ext:	rets
	.word ext
	.data
	.word ext
