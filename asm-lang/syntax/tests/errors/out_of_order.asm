asm out_of_order
signature:
  controlled a: E
  enum domain E = {AA | BB} //~ L073
definitions:
