asm reserved_name
signature:
  controlled agent: Integer //~ L054
definitions:
