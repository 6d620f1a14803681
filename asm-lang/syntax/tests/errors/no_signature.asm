asm no_signature
controlled a: Integer //~ L074
definitions:
