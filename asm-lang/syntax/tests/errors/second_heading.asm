asm a
signature:
definitions:
asm b //~ L013
