asm out_of_order
signature:
  controlled a: E
  enum domain E = {AA | BB} //~ L053
definitions:
