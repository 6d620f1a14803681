asm
signature: //~ L038
definitions:
  main rule r_Main = skip
