asm a
signature:
definitions:
asm b //~ L022
