asm reserved_name
signature:
  controlled agent: Integer //~ L034
definitions:
