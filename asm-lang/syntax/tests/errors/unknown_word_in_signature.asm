asm unknown_word_in_signature
signature:
  controled a: Integer //~ L053
  controlled b: Integer
definitions:
