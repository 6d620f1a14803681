asm unknown_section
signature:
defintions: //~ L033
  main rule r_Main = skip
