"""The paper's section 6 computed again, beside what it prints."""
