asm no_signature
controlled a: Integer //~ L054
definitions:
