asm no_definitions_at_all
signature:
  controlled a: Integer //~ L074