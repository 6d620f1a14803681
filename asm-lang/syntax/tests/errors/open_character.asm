asm open_character
signature:
definitions:
  main rule r_Main = a := 'it //~ L004
