asm open_comment
signature:
definitions:
  main rule r_Main = skip
  /* never closed //~ L003
