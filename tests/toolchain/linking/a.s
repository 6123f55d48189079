	.text
	.global	_start, ext, other
_start:	ldp	@tbl
	ldi	@tbl,r0
	ldi	@tbl+2,r0
	ldi	@ext,r0
	ldi	@ext+3,r0
	ldp	@ext+70000
	ldhi	ext,ar0
	or	@ext,ar0
	call	ext
	call	local
	bz	ext
	bz	local
	bd	local
	brd	ext
	ldi	@ext,r1
local:	nop
	.sect "more"
far:	bz	local
	br	local
	bz	ext
	rptb	local
	.data
	.space 5
tbl:	.word	tbl, ext, ext+5, local
	.word	tbl+7
	.word	$
	.bss	buf,100

